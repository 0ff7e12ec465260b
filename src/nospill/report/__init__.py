"""A plan on one page to share: scenario, verdict, figures and evidence as one HTML file, and as PDF."""

from nospill.report.contents import Report as Report
from nospill.report.contents import make_report as make_report
from nospill.report.second_opinion import SecondOpinion as SecondOpinion
from nospill.report.second_opinion import read_second_opinion as read_second_opinion
from nospill.report.stopping import read_stopping_table as read_stopping_table
from nospill.report.writing import save_report as save_report
